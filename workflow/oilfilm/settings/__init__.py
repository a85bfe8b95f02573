"""Settings of a run: configuration, campaign, rigs, oils and bearings."""

"""What a run is told: configuration, campaign, rigs, oils and bearings."""

"""The report of a campaign: finished tables and figures in, one HTML text out."""

"""The fit's result in the forms that bearing engineers use, each made from one `Description`."""

from oilfilm.outputs.exports.campaign import export_campaign

__all__ = ["export_campaign"]

"""The fit's result in the forms that bearing engineers use, each made from one `Description`."""

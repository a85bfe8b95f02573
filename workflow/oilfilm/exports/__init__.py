"""A fit in the forms that bearing engineers use; each is made from one `Description`."""

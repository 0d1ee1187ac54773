"""The payload experiment of section 8: methods side by side, what each error consists of, and a verdict."""

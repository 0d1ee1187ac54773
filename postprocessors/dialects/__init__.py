"""The languages of controllers: a folder each, with its writer, its reader and what its controller promises."""

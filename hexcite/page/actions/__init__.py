"""What forms of the stages ask for.

Each module is imported when it is first needed: the first page does not wait for it.
"""

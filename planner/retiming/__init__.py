"""A planned motion at another pace: as controllers time it, or as fast as limits allow."""

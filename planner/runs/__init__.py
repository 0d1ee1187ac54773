"""Programs on a controller and the recordings that come of them."""

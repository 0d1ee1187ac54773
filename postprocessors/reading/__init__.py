"""Reads programs back, independently of what wrote them."""

"""What a figure or a scene shows, as a value, and how plotly, matplotlib and the page draw it."""

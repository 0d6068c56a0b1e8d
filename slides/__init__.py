"""The lectures."""

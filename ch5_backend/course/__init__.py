"""The implementation of ./course: one module per idea."""

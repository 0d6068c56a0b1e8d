"""What stands behind ./course: one module per idea."""

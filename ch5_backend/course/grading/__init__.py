"""./course grade: marks for untrusted submissions."""

"""./course grade: marks for submissions that nobody trusts."""

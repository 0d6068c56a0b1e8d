"""The numbers that pages, decks, model answers and tests cite, a module for each experiment: table → values."""

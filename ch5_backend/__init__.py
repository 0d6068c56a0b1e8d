"""The project's Python is imported by its path from the project's folder, as its C++ is included: ch5_backend.figures."""

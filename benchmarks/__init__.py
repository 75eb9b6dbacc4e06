"""What Kinopix reaches, one command a figure; see README.md here."""

"""What a campaign found, read from its folder."""

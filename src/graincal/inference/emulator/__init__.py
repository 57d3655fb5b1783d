"""What a response would be where nothing was evaluated."""

"""A page that follows a campaign: it reads, and changes nothing."""

"""What is kept: the folder of a campaign, its database, and what else is written there."""

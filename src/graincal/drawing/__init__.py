"""Figures as plain records, and what draws them: one palette for page, file and notebook."""

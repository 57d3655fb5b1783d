"""What both methods share with whoever drives them: they are asked for samples, and told what became of these."""

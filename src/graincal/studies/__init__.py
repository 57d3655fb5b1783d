"""Studies that were published, as commands that anyone can repeat: graincal reproduce."""

"""The AmigoBot: its body, how it moves, what it believes of its pose, who drives it."""

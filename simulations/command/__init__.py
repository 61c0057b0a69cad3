"""What every command shares: its command line, its progress lines, and how it ends."""

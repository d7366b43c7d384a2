"""What do the joints carry, and how much does the arm deflect?"""

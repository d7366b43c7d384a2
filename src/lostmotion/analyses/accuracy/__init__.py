"""How accurate is the arm?"""

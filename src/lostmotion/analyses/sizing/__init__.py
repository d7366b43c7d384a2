"""Which sections and bought parts does the arm need?"""

"""How accurate is the arm in each cell of its workspace?"""

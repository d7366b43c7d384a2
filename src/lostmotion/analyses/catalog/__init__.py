"""What is in the catalogue?"""

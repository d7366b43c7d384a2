"""What does a target on the tool require of each part?"""

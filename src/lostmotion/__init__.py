"""lostmotion: how accurate will this robot arm be before it is built, where, and which part is to blame?"""

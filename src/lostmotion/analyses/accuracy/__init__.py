"""Accuracy of an arm: error, AP, RP and error budget."""

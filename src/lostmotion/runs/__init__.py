"""Big runs: many poses or many designs in fixed blocks, kept in a store that a killed run goes on
from; these modules open files.
"""

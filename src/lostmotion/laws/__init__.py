"""Physics and chance from books: arrays in, arrays out, a citation each, no product names."""

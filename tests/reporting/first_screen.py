"""What a reader sees first of a result."""


def first_screen(sheet):
    """Return the headline and the statements below it as one text."""
    return " ".join([sheet.verdict, *(text for _, text in sheet.brief)])

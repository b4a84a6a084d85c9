"""What the site is made of beside its pages: gallery, help, tolerances, verdicts, pictures,
mathematics.
"""

"""What is drawn of a mechanism, for pictures and pages alike: marks on links, sides, colours."""

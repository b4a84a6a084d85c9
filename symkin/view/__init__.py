"""What symkin shows: tables and pictures."""

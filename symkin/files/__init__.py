"""Files that symkin reads and writes: tables of numbers, results, pictures."""

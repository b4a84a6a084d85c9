"""What several studies use: reports, guesses, words of rows, pictures of many modes."""

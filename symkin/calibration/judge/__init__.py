"""What an estimate is worth: identifiability, statistics, outliers, predictions, and mistakes in
the data.
"""

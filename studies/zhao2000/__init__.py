"""3-TRT + SPS platform of four freedoms (Zhao 2000)."""

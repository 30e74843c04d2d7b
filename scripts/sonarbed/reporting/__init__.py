"""The kit that reports are made with: drives, statistics, drawing, sections."""

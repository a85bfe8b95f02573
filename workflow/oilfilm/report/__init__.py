"""What people and programs get: figures, report, exports, summary, metadata."""

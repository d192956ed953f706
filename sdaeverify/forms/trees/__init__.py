"""Trees of derivatives that a form has: the interface of its classes, and draws of related problems far out."""

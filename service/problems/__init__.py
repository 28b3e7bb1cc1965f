"""Problem documents (RFC 9457) and the errors that become them."""

"""What all tests need."""

import signal

# A shell starts jobs in the background with Ctrl-C ignored, and so may CI.
signal.signal(signal.SIGINT, signal.default_int_handler)

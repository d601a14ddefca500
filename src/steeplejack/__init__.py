"""What is true of robots that climb tall structures with parallel mechanisms, room by room; see the README."""

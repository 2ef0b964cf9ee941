//! eikona-numeric

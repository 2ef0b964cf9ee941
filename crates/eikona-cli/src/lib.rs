//! eikona-cli

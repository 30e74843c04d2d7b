"""Sonars that look along a fan of rays: the simple cone and that of Webots."""

"""Line figures of mechanisms, as textbooks print them, without a browser."""

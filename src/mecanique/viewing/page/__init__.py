"""The scene as one offline HTML page."""

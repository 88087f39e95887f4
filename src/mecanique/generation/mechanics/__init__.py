"""What is written as a program: the equations of motion in closed form, or by recursion."""

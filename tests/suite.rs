mod robot;
